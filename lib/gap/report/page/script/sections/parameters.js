// How far the ship's own parameters had to move.
const MOST_PARAMETERS = 24;
const FAR = 2;  // standard deviations

const parametersSection = ({findings: {null_fit: fit}}) => {
  const shifts = Object.entries(fit.parameters);
  if (shifts.length === 0) return;
  const sorted = shifts.filter(([, p]) => isKnown(p.shift_in_prior_sd))
                     .sort(([, a], [, b]) => Math.abs(b.shift_in_prior_sd) - Math.abs(a.shift_in_prior_sd));
  // Far from the stated value, and not because nothing holds it there.
  const isFar = (p) =>
      Math.abs(p.shift_in_prior_sd) > FAR && Math.abs(Math.log(p.factor)) > FAR * p.factor_sd / p.factor;
  const far = sorted.filter(([, p]) => isFar(p)).length;
  const part = section(
      'How far the ship\'s parameters had to move',
      far > 0 ? `${count(far)} of ${count(sorted.length)} moved by more than two standard deviations of their stated ` +
              'uncertainty: they may stand in for missing physics.' :
                'None moved by more than two standard deviations of its stated uncertainty.');
  if (sorted.length > 0)
    bars(
        part, 'shift of each parameter',
        sorted.slice(0, MOST_PARAMETERS)
            .map(([name, p]) => ({
                   label: name,
                   value: p.shift_in_prior_sd,
                   color: isFar(p) ? COLOR.yaw : '#8fa6b8',
                   tip: `${fixed(p.shift_in_prior_sd)} sd: factor ${withSd(p.factor, p.factor_sd)}`
                 })),
        {axis: 'shift in standard deviations of the stated uncertainty', markValues: [-FAR, FAR], min: -3, max: 3});
  if (sorted.length > MOST_PARAMETERS)
    part.append(paragraph(`${count(sorted.length - MOST_PARAMETERS)} more that are not drawn`, 'note'));
};
