// The verdict, the size of the model error, and what a reader has to be warned of.
const verdictSection = (report) => {
  const {findings, explanation} = report;
  const {verdict, sentence} = explanation || findings;
  const hero = element('div', {class: 'hero ' + verdict});
  page.append(hero);
  hero.append(element('div', {class: 'title'}, report.title));
  hero.append(element('h1', {}, element('span', {class: 'badge'}, VERDICT[verdict]), sentence));
  if (!explanation && findings.detection.reason) hero.append(paragraph(findings.detection.reason));
  for (const {text, command} of report.steps) {
    if (text) hero.append(paragraph('What to do: ' + text + '.'));
    if (command) hero.append(element('pre', {class: 'command'}, command));
  }
  hero.append(verdictCards(report));
  const {tau_s: tau} = findings.sigma_w;
  hero.append(paragraph(
      'Model error: standard deviation of the acceleration that the simulator lacks to follow the recordings' +
          (isKnown(tau) && tau > 0 ? `, correlated over ${seconds(tau)}.` : '.'),
      'note'));
  if (findings.ensemble) hero.append(ensembleNote(findings.ensemble));
  for (const text of warnings(findings)) hero.append(element('div', {class: 'warning'}, text));
};

const verdictCards = ({findings, explanation}) => {
  const cards = element('div', {class: 'cards'});
  const card = (label, value, unit, below) => cards.append(element(
      'div', {class: 'card'}, element('div', {class: 'label'}, label),
      element('div', {class: 'value'}, value, element('small', {}, ' ' + unit)),
      element('div', {class: 'below'}, below)));
  const {sigma_w: sigma, detection} = findings;
  for (const axis of AXES)
    card(
        'Model error, ' + axis, modelError(sigma, axis), ACCELERATION[axis].unit,
        percent(sigma[axis + '_share_of_typical']) + ' of the typical acceleration');
  const gain = explanation && explanation.chosen.length > 0 ?
      [explanation.heldout_gain_nats, explanation.heldout_gain_sd_nats] :
      [detection.heldout_gain, detection.heldout_gain_sd];
  card(
      'p-value, if nothing is missing', pValue((explanation || findings).p_value), '',
      isKnown(gain[0]) && gain[0] !== 0 ? 'unseen data predicted better by ' + natsWithSd(...gain) : '');
  return cards;
};

const ensembleNote = ({name, members, outside_share: outside, members_sd: sd}) => paragraph(
    `Simulator: the ensemble ${name} of ${count(members)} networks. Standard deviation of their accelerations: ` +
        `${accelerations(sd)}. Beyond the training data: ${percent(outside)} of the points.`,
    'note');

const warnings = ({conventions, audit, faults_taken_out: corrected, null_fit: fit}) =>
    [...conventions.contradicted.map((reading) => reading.sentence),
     ...audit.faults.map(
         (fault) => fault.sentence + (corrected ? ' (corrected before the fit)' : ' (still in the data)')),
     ...(fit.converged ? [] : [`The fit has not converged after ${
                                  count(fit.iterations)} iterations: do not rely on what follows.`]),
];
