// Every number of the page, and every word that stands for a value, becomes text here and nowhere else.
const MINUS = '\u2212', PLUS_MINUS = ' \u00b1 ', DASH = '\u2013', ARROW = ' \u2192 ', SQUARED = '\u00b2';
const TEN_TO_MINUS_3 = '10\u207b\u00b3 ';
const NONE = DASH;

const isKnown = (x) => typeof x === 'number' && Number.isFinite(x);
const signed = (text) => text.replace(/^-/, MINUS);

const fixed = (x, decimals = 2) => (isKnown(x) ? signed(x.toFixed(decimals)) : NONE);

const short = (x, digits = 3) => {
  if (!isKnown(x)) return NONE;
  if (x === 0) return '0';
  const size = Math.abs(x);
  return signed(size >= 1e-4 && size < 1e6 ? String(Number(x.toPrecision(digits))) : x.toExponential(digits - 1));
};

// One digit of the standard deviation, two where it begins with 1 or 2.
const decimalsOf = (sd) => Math.max(0, -Math.floor(Math.log10(sd / 3)));
const MOST_DECIMALS = 7;

const withSd = (x, sd) => {
  if (!isKnown(x)) return NONE;
  if (!isKnown(sd) || sd <= 0) return short(x);
  const decimals = decimalsOf(sd);
  return decimals > MOST_DECIMALS ? short(x) + PLUS_MINUS + short(sd, 2) :
                                    fixed(x, decimals) + PLUS_MINUS + sd.toFixed(decimals);
};

// The limits of an interval of 95 %, with as many decimals as withSd gives its middle.
const between = ([low, high]) => {
  const decimals = isKnown(low) && isKnown(high) && low < high ? decimalsOf((high - low) / 4) : MOST_DECIMALS + 1;
  return decimals > MOST_DECIMALS ? `${short(low)} to ${short(high)}` :
                                    `${fixed(low, decimals)} to ${fixed(high, decimals)}`;
};
const betweenShort = ([low, high]) => `${short(low)} to ${short(high)}`;

const percent = (share) => {
  if (!isKnown(share)) return NONE;
  const size = Math.abs(100 * share);
  return size > 0 && size < 0.1 ? '< 0.1 %' : fixed(100 * share, size < 10 ? 1 : 0) + ' %';
};
const percentTick = (percents) => percents + ' %';
const tick = (x) => short(x, 6);
const positionTick = (x) => short(x, 5);

const pValue = (p) => (!isKnown(p) ? NONE : p < 1e-4 ? '< 0.0001' : short(p, 2));
const probability = (p) => short(p, 2);

// Units: as the JSON writes them, '1' where there is none.
const unitAfter = (unit) => (unit === '1' ? '' : ' ' + unit.replace('^2', SQUARED));
const estimate = ({estimate: value, sd, unit}) => withSd(value, sd) + unitAfter(unit);
const seconds = (t, digits) => short(t, digits) + ' s';
const atTime = (t) => `t = ${seconds(t, 6)}`;
const timeSpan = (start, end) => `${short(start, 5)} ${DASH} ${short(end, 5)}`;
const LOG_LIKELIHOOD = ' (log-likelihood)';
const nats = (x) => short(x) + LOG_LIKELIHOOD;
const natsWithSd = (x, sd) => withSd(x, sd) + LOG_LIKELIHOOD;
const shipLengths = (x, sd) => withSd(x, sd) + ' L_pp';
const change = (before, after) => short(before) + ARROW + short(after);

// Accelerations by axis: the end of their keys in the JSON, and how they are shown.
const AXES = ['surge', 'sway', 'yaw'];
const ACCELERATION = {
  surge: {key: 'mps2', scale: 1e3, unit: 'mm/s' + SQUARED},
  sway: {key: 'mps2', scale: 1e3, unit: 'mm/s' + SQUARED},
  yaw: {key: 'degps2', scale: 1, unit: 'deg/s' + SQUARED},
};
const accelerationOf = (values, axis) => {
  const {key, scale} = ACCELERATION[axis], value = values[`${axis}_${key}`];
  return isKnown(value) ? scale * value : null;
};
const acceleration = (values, axis) => `${short(accelerationOf(values, axis), 2)} ${ACCELERATION[axis].unit}`;
const accelerations = (values) => `surge ${short(accelerationOf(values, 'surge'), 2)}, ` +
    `sway ${acceleration(values, 'sway')}, yaw ${acceleration(values, 'yaw')}`;
const modelError = (sigma, axis) => {
  const {key, scale} = ACCELERATION[axis], sd = sigma[`${axis}_sd_${key}`];
  return withSd(accelerationOf(sigma, axis), isKnown(sd) ? scale * sd : null);
};

// Words.
const VERDICT = {
  mismatch: 'mismatch',
  'no-mismatch': 'no mismatch',
  undecided: 'undecided',
};
const hypothesisName = (name) => (name === 'none' ? 'nothing' : name);
const yesOrNo = (is) => (is ? 'yes' : 'no');
const orNotKnown = (text) => text ?? 'not known';
const unlessZero = (x, wordForZero, format) => (x === 0 ? wordForZero : format(x));
const count = (n) => String(n);
const counted = (label, n, word) => label + (n > 0 ? `  (${n} ${word})` : '');
const sideOf = (x) => (x < 0 ? 'astern' : 'ahead');
