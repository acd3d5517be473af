// What kind of force: evidence of each frame, gain of each module. The best comes first and is colored.
const forceSection = ({findings: {located: {frames, modules}}}) => {
  if (frames.length === 0 && modules.length === 0) return;
  const boxes = grid(section('What kind of force it is'), frames.length > 0 && modules.length > 0 ? 'two' : '');
  const color = (i) => (i === 0 ? COLOR.surge : COLOR.pale);
  if (frames.length > 0)
    bars(
        boxIn(
            boxes, 'In which frame the residual is constant',
            'Log-evidence against no residual at all: the longer, the better this alone describes it.'),
        'evidence of each frame',
        frames.map((frame, i) => ({
                     label: frame.meaning,
                     value: frame.log_evidence,
                     color: color(i),
                     tip: `${nats(frame.log_evidence)}, ${percent(frame.share)} of the residual`,
                   })),
        {min: 0});
  if (modules.length > 0)
    bars(
        boxIn(
            boxes, 'Which part of the model, if it may vary, explains it',
            'Gain of log-likelihood when the force of one module may vary by a slowly changing factor.'),
        'gain of each module',
        modules.map((module, i) => ({
                      label: module.name,
                      value: module.log_likelihood_gain,
                      color: color(i),
                      tip: `${nats(module.log_likelihood_gain)}; factor varies by ${short(module.gain_sd, 2)}; ` +
                          `leaves ${percent(module.sigma_w_factor)} of the model error`,
                    })),
        {min: 0});
};
