// Maneuvers that would distinguish what is still possible.
const CERTAIN = 0.95;

const nextManeuverSection = ({explanation: {next}}) => {
  if (next.maneuvers.length === 0) return;
  const part = section(
      'What would distinguish them',
      'Maneuvers simulated under each hypothesis that is still possible, with the noise and the model error of ' +
          'these recordings: the probability of the right name that is to be expected afterwards. Now it is ' +
          probability(next.p_right_now) + '.');
  bars(
      part, 'expected probability of the right name',
      next.maneuvers.map((m) => ({
                           label: `${m.maneuver} (${seconds(m.duration_s)})`,
                           value: m.p_right,
                           color: m.p_right >= CERTAIN ? COLOR.sway : COLOR.grey,
                           tip: `${short(m.p_right)}: ${m.command}`,
                         })),
      {axis: 'expected probability of the right name', markValues: [next.p_right_now], min: 0, max: 1});
};
