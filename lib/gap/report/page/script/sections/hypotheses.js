// What is missing, by probability, with its parameters.
const MOST_HYPOTHESES = 10, WORTH_A_ROW = 0.01;

const hypothesesSection = ({explanation}) => {
  const part = section(
      'What is missing',
      'Effects that were fitted to the recordings beside the ship\'s uncertain parameters, by their probability. ' +
          'Evidence: log-likelihood, averaged over what is left open, against nothing missing. Unseen data: how much better (log-likelihood) what was left out in turn is predicted than with nothing missing.');
  const shown = explanation.hypotheses
                    .filter((h) => h.probability >= WORTH_A_ROW || h.chosen || h.effects?.length === 0)
                    .slice(0, MOST_HYPOTHESES);
  bars(
      part, 'probability of what may be missing',
      shown.map((h) => ({
                  label: hypothesisName(h.name),
                  value: h.probability,
                  color: h.chosen ? COLOR.sway : COLOR.grey,
                  tip: `${short(h.probability)}: ${h.sentence}`,
                })),
      {axis: 'probability', min: 0, max: 1});
  const others = 1 - shown.reduce((sum, h) => sum + h.probability, 0);  // also of effects that were not fitted
  const rows = shown.flatMap(rowsOfHypothesis);
  if (others >= WORTH_A_ROW)
    rows.push({first: true, h: {name: 'others', probability: others, converged: null, log_evidence: null}});
  part.append(hypothesesTable(rows));
  inclusionBars(part, explanation.inclusion);
  priorBars(part, rows.filter(({h, p}) => p && isKnown(p.prior95?.[0]) && h.chosen));
};

// Over all hypotheses, also those that were not fitted.
const inclusionBars = (part, inclusion) => {
  const shown = Object.entries(inclusion)
                    .filter(([, p]) => p >= WORTH_A_ROW)
                    .sort(([, a], [, b]) => b - a)
                    .slice(0, MOST_HYPOTHESES);
  if (shown.length === 0) return;
  bars(
      part, 'how probably each acts',
      shown.map(([name, p]) => ({
                  label: name.replace('coefficient:', 'off: '),
                  value: p,
                  color: COLOR.grey,
                  tip: name.startsWith('coefficient:') ?
                      `${short(p)}: ${name.slice('coefficient:'.length)} is off by far more than the ship file states` :
                      `${short(p)}: ${name} acts, alone or beside others`,
                })),
      {axis: 'probability that it acts, whatever else does (off: a coefficient, by far more than the ship file states)', min: 0, max: 1});
};

// A row for each parameter; the first one of a hypothesis shows the hypothesis.
const rowsOfHypothesis = (h) => {
  const parameters = Object.entries(h.parameters);
  if (parameters.length === 0) return [{h, first: true}];
  return parameters.map(([name, p], i) => ({h, name, p, first: i === 0}));
};

const hypothesesTable = (rows) => {
  const once = (format) => ({h, first}) => (first ? format(h) : '');
  const ofParameter = (format) => ({p}) => (p ? format(p) : '');
  return table(
             [
               {name: 'Missing', of: once((h) => hypothesisName(h.name))},
               {name: 'Probability', of: once((h) => probability(h.probability)), kind: 'number'},
               {name: 'Evidence', of: once((h) => short(h.log_evidence)), kind: 'number'},
               {name: 'Fit', of: once((h) => ({true: 'converged', false: 'not converged'}[h.converged] ?? ''))},
               {
                 name: 'Unseen data',
                 of: once((h) => withSd(h.heldout_gain_nats, h.heldout_gain_sd_nats)),
                 kind: 'number'
               },
               {name: 'Parameter', of: ({name}) => name || ''},
               {name: 'Estimate', of: ofParameter((p) => estimate(p) + (p.at_bound ? ', at the bound of what is possible' : '')), kind: 'number'},
               {name: '95 %', of: ofParameter((p) => between(p.ci95)), kind: 'number'},
             ],
             rows)
      .node;
};

// Parameters against what was believed before.
const priorBars = (part, rows) => {
  if (rows.length === 0) return;
  const share = ({prior95: [low, high]}, x) => (x - low) / (high - low);
  bars(
      part, 'parameters against what was believed before',
      rows.map(({name, p}) => ({
                 label: name,
                 low: Math.max(-0.5, share(p, p.ci95[0])),
                 high: Math.min(1.5, share(p, p.ci95[1])),
                 value: share(p, p.estimate),
                 color: COLOR.sway,
                 tip: `${estimate(p)}, 95 % ${between(p.ci95)}; before ${betweenShort(p.prior95)}`,
               })),
      {axis: '95 % interval against that of what was believed before (0 to 1), drawn from -0.5 to 1.5', markValues: [0, 1], min: 0, max: 1});
};
