// Maneuvers that would distinguish what is still possible.
const CERTAIN = 0.95;

const nextManeuverSection = ({explanation: {next}}) => {
  if (next.maneuvers.length + next.records.length === 0) return;
  const part = section(
      'What would distinguish them',
      'Maneuvers simulated under each hypothesis that is still possible, with the noise and the model error of ' +
          'these recordings: the probability of the right name that is to be expected afterwards. Now it is ' +
          probability(next.p_right_now) + '; what was fitted has ' + probability(next.p_reachable) +
          ' together, which nothing can surpass.' +
          (next.advised.nothing_tells ? ' Nothing of these would tell.' : ''));
  bars(
      part, 'expected probability of the right name',
      next.maneuvers.map((m) => ({
                           label: `${m.maneuver} (${seconds(m.duration_s)})`,
                           value: m.p_right,
                           color: m.p_right >= CERTAIN * next.p_reachable ? COLOR.sway : COLOR.grey,
                           tip: `${short(m.p_right)}: ${m.command}`,
                         })),
      {axis: 'expected probability of the right name', markValues: [next.p_right_now], min: 0, max: 1});
  const expected = {name: 'Expected', of: (one) => probability(one.p_right), kind: 'number'};
  if (next.sequences.length > 0)
    part.append(table(
                    [
                      {name: 'Two of them', of: (s) => s.maneuvers.join(' and ')},
                      {name: 'Time', of: (s) => seconds(s.duration_s), kind: 'number'},
                      expected,
                    ],
                    next.sequences)
                    .node);
  if (next.records.length > 0)
    part.append(table(
                    [
                      {name: 'What was not recorded', of: (r) => r.record},
                      {name: 'In', of: (r) => r.maneuver === null ? 'the same maneuvers as now' : r.maneuver},
                      expected,
                    ],
                    next.records)
                    .node);
};
