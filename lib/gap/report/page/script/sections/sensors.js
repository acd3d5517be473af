// Faults of sensors, quality of each channel, and how channels may be read otherwise.
const sensorsSection = ({findings: {audit, conventions}}) => {
  const part = section('Sensors and conventions');
  part.append(paragraph(
      audit.faults.length > 0            ? 'The recordings contradict themselves, whatever the forces:' :
          audit.verdict === 'consistent' ? 'No fault of a sensor: the recordings agree with themselves.' :
                                           'The sensors could not be checked.'));
  if (audit.faults.length > 0) part.append(faultsTable(audit.faults));
  if (audit.log_through_water !== null)
    part.append(paragraph(
        audit.log_through_water ? 'The velocities are through the water.' : 'The velocities are over ground.'));
  const channels = Object.entries(audit.channels);
  if (channels.length > 0) part.append(channelsTable(channels));
  const {hypotheses} = audit;
  if (hypotheses.length > 0)
    part.append(folded(`All ${count(hypotheses.length)} sensor faults that were tested`, faultsTable(hypotheses)));
  readings(part, conventions);
};

const faultsTable = (faults) => {
  const estimates = ({parameters}) => {
    const all = Object.entries(parameters);
    return all.map(([name, p]) => (all.length > 1 ? name + ' ' : '') + estimate(p)).join(', ');
  };
  return table(
             [
               {name: 'Fault', of: (f) => f.name, kind: 'name'},
               {name: 'Estimate', of: estimates},
               {name: 'Unseen data better by (log-likelihood)', of: (f) => withSd(f.heldout_gain, f.heldout_gain_sd), kind: 'number'},
               {name: 'p', of: (f) => pValue(f.p_value), kind: 'number'},
               {name: 'Meaning', of: (f) => f.sentence},
             ],
             faults)
      .node;
};

const channelsTable = (channels) => {
  const inUnit = (x, {unit}) => short(x, 2) + unitAfter(unit), time = (t) => seconds(t, 2);
  return table(
             [
               {name: 'Channel', of: ([name]) => name},
               {name: 'Noise, sd', of: ([, c]) => inUnit(c.noise_sd, c), kind: 'number'},
               {name: 'Correlated over', of: ([, c]) => unlessZero(c.correlation_s, 'white', time), kind: 'number'},
               {name: 'Filter', of: ([, c]) => unlessZero(c.filter_s, 'none', time), kind: 'number'},
               {name: 'Missing', of: ([, c]) => unlessZero(c.missing_share, 'none', percent), kind: 'number'},
               {name: 'Frozen', of: ([, c]) => unlessZero(c.frozen_share, 'none', percent), kind: 'number'},
               {
                 name: 'Resolution',
                 of: ([, c]) => unlessZero(c.resolution, 'continuous', (x) => inUnit(x, c)),
                 kind: 'number'
               },
             ],
             channels)
      .node;
};

const readings = (part, {contradicted, tested}) => {
  const readingsTable = (rows) => table(
                                      [
                                        {name: 'Channel', of: (r) => r.channel},
                                        {name: 'Read as', of: (r) => r.name},
                                        {name: 'Log-odds', of: (r) => short(r.log_odds), kind: 'number'},
                                        {name: 'Error, ratio', of: (r) => short(r.error_ratio), kind: 'number'},
                                        {name: 'Meaning', of: (r) => r.sentence},
                                      ],
                                      rows)
                                      .node;
  if (contradicted.length > 0) {
    part.append(paragraph('These channels read better in another way than stated:'));
    part.append(readingsTable(contradicted));
  } else if (tested.length > 0) {
    part.append(paragraph('Signs, units and frames: no other reading fits better than the stated one.'));
  }
  if (tested.length > 0)
    part.append(folded(`All ${count(tested.length)} other readings that were tested`, readingsTable(tested)));
};
