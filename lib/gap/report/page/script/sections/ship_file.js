const WORTH_A_BAR = 0.5;  // log-likelihood: less is rounding and chance

// What the recordings say of the ship's file, apart from missing physics.
const shipFileSection = ({explanation: {ship_file: file, modules, beyond_recorded: beyond}}) => {
  const part = section('The ship file', file.sentence);
  const names = Object.keys(modules).sort((a, b) => (modules[b] ?? 0) - (modules[a] ?? 0));
  if (names.some((name) => modules[name] >= WORTH_A_BAR))
    bars(
        part, 'what each module gains',
        names.map((name) => ({
                    label: name,
                    value: Math.max(0, modules[name] ?? 0),
                    color: file.findings.some((f) => f.name === name) ? COLOR.sway : COLOR.grey,
                    tip: `${name}: ${short(modules[name])}`,
                  })),
        {axis: 'unseen data predicted better when this module alone is fitted (log-likelihood)', min: 0});
  if (file.findings.length > 0)
    part.append(table(
                    [
                      {name: 'Off', of: (f) => f.name},
                      {name: 'Factor', of: (f) => short(f.factor), kind: 'number'},
                      {name: '95 %', of: (f) => between(f.ci95), kind: 'number'},
                      {name: 'What', of: (f) => f.sentence},
                    ],
                    file.findings)
                    .node);
  if (beyond)
    part.append(paragraph(
        `Fitted to rudder angles up to ${short(beyond.recorded_rudder_deg)} deg. At ${short(beyond.rudder_deg)} deg in still water ` +
            `ship.json turns with a tactical diameter of ${between(beyond.ci95)} ship lengths (95 %, ` +
            'if the forms of its forces hold there).',
        'warning'));
};
