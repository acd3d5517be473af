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
  const axis = 'expected probability of the right name';
  const show = (title, list, label, tip) => {
    if (list.length === 0) return;
    bars(
        part, title,
        list.map((one) => ({
                   label: label(one),
                   value: one.p_right,
                   color: one.p_right >= CERTAIN * next.p_reachable ? COLOR.sway : COLOR.grey,
                   tip: `${short(one.p_right)}: ${tip(one)}`,
                 })),
        {axis, markValues: [next.p_right_now], min: 0, max: 1});
  };
  show('one maneuver', next.maneuvers, (m) => `${m.maneuver} (${seconds(m.duration_s)})`, (m) => m.command);
  show('two of them', next.sequences, (s) => `${s.maneuvers.join(' and ')} (${seconds(s.duration_s)})`,
       (s) => s.maneuvers.join(' and '));
  show('what was not recorded', next.records, (r) => r.record + (r.maneuver === null ? '' : `, in ${r.maneuver}`),
       (r) => r.record);
};
