// Known effects, each alone, and those that the recordings cannot show.
const MOST_EFFECTS = 12;

const effectsSection = ({findings: {detection: {effects, untested}}}) => {
  if (effects.length > 0) testedEffects(effects);
  if (untested.length > 0) page.append(folded('Effects that these recordings cannot show', list(untested)));
};

const testedEffects = (effects) => {
  const part = section(
      effects.some((effect) => effect.heldout_gain > 0) ? 'Known effects that would fit' :
                                                          'Known effects: none fits better',
      'Each effect of the catalogue alone, by the log-likelihood that it gains' +
          ' on recordings that it was not fitted to (bar: one standard error). A first look, not a name:' +
          ' gap-explain lets them compete.');
  const shown = effects.filter((effect) => isKnown(effect.heldout_gain)).slice(0, MOST_EFFECTS);
  const isClear = ({heldout_gain: gain, heldout_gain_sd: sd}) => isKnown(sd) && gain > 2 * sd;
  const gain = (effect) => [effect.heldout_gain, effect.heldout_gain_sd];
  if (shown.length > 0)
    bars(
        part, 'held-out gain of each effect',
        shown.map((effect) => ({
                    label: effect.name,
                    value: effect.heldout_gain,
                    sd: effect.heldout_gain_sd,
                    color: isClear(effect) ? COLOR.surge : COLOR.pale,
                    tip: `${natsWithSd(...gain(effect))}, p ${pValue(effect.p_value)}, ` +
                        `log Bayes factor ${short(effect.log_bayes_factor)}`,
                  })),
        {axis: 'unseen data predicted better by (log-likelihood)'});
  const all = table(
      [
        {name: 'Effect', of: (e) => e.name, kind: 'name'},
        {name: 'Unseen data better by (log-likelihood)', of: (e) => withSd(...gain(e)), kind: 'number'},
        {name: 'Log Bayes factor', of: (e) => short(e.log_bayes_factor), kind: 'number'},
        {name: 'p alone', of: (e) => pValue(e.p_value), kind: 'number'},
      ],
      effects);
  part.append(folded(`All ${count(effects.length)} effects as a table`, all.node));
};
