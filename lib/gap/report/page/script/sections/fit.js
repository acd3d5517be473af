// What to keep in mind, and the figures of the fit.
const noticesSection = ({findings: {notices, audit, conventions}}) => {
  const all = [...notices, ...audit.notices, ...conventions.unchecked];
  if (all.length > 0) section('To keep in mind').append(list(all));
};

const fitSection = ({findings: {null_fit: fit, detection}}) => {
  const figures = [
    ['Converged', yesOrNo(fit.converged)],
    ['Iterations', count(fit.iterations)],
    [
      'Largest gradient, parameters (in prior sd) / noise levels',
      short(fit.gradient, 2) + ' / ' + short(fit.noise_gradient, 2)
    ],
    ['Measurements', count(fit.samples)],
    ['Outliers set aside', count(fit.outliers)],
    ['Time step', seconds(fit.step_s)],
    ['Log-likelihood per measurement', short(fit.log_likelihood_per_sample, 4)],
    ['Chance that the remaining errors are white noise, p', pValue(detection.whiteness_p_value)],
    ...Object.entries(fit.noise).map(([name, n]) => ['Noise of ' + name, withSd(n.estimate, n.sd)]),
  ];
  const {node} =
      table([{name: '', of: ([name]) => name}, {name: '', of: ([, value]) => value, kind: 'number'}], figures);
  node.style.maxWidth = '640px';
  section('The fit').append(node);
};
