'use strict';
// Draws the findings of gap-locate from the JSON in #data: `findings` is locate.json as docs/gap-locate.md describes
// it, `recordings` holds the thinned residuals. All text enters the page as text, never as markup.
(() => {
  const body = document.body;
  const problems = [];
  const fail = (message) => {
    problems.push(String(message));
    body.dataset.errors = problems.join(' | ');
  };
  window.addEventListener('error', (event) => fail(event.message));

  const {title, provenance, findings, explanation, recordings} = JSON.parse(document.getElementById('data').textContent);
  const {located, audit, conventions, detection, null_fit: fit, sigma_w: sigma} = findings;
  const AXES = ['surge', 'sway', 'yaw'];
  // Okabe and Ito's colors: told apart with any color vision.
  const COLOR = {surge: '#0072b2', sway: '#009e73', yaw: '#d55e00', grey: '#7b8794', located: '#e69f00'};
  const clear = (color, alpha) => color + Math.round(255 * alpha).toString(16).padStart(2, '0');

  // Numbers.
  const known = (x) => typeof x === 'number' && Number.isFinite(x);
  const MINUS = '\u2212', PM = ' \u00b1 ', NONE = '\u2013';
  const signed = (text) => text.replace(/^-/, MINUS);
  const fixed = (x, digits = 2) => (known(x) ? signed(x.toFixed(digits)) : NONE);
  const short = (x, digits = 3) => {
    if (!known(x)) return NONE;
    if (x === 0) return '0';
    const size = Math.abs(x);
    return signed(size >= 1e-4 && size < 1e6 ? String(Number(x.toPrecision(digits))) : x.toExponential(digits - 1));
  };
  // One digit of the standard deviation, two where it begins with 1 or 2.
  const digitsOf = (sd) => Math.max(0, -Math.floor(Math.log10(sd / 3)));
  const withSd = (x, sd) => {
    if (!known(x)) return NONE;
    if (!known(sd) || sd <= 0) return short(x);
    const digits = digitsOf(sd);
    return digits > 7 ? short(x) + PM + short(sd, 2) : fixed(x, digits) + PM + sd.toFixed(digits);
  };
  // The limits of an interval of 95 %, as exactly as its middle is told.
  const between = ([low, high]) => {
    const digits = known(low) && known(high) && low < high ? digitsOf((high - low) / 4) : 8;
    return digits > 7 ? `${short(low)} to ${short(high)}` : `${fixed(low, digits)} to ${fixed(high, digits)}`;
  };
  const percent = (x) => {
    if (!known(x)) return NONE;
    const size = Math.abs(100 * x);
    return size > 0 && size < 0.1 ? '< 0.1 %' : fixed(100 * x, size < 10 ? 1 : 0) + ' %';
  };
  const pValue = (p) => (!known(p) ? NONE : p < 1e-4 ? '< 0.0001' : short(p, 2));
  const printed = (unit) => (unit === '1' ? '' : ' ' + unit.replace('^2', '\u00b2'));

  // Page.
  const element = (tag, options = {}, ...children) => {
    const node = document.createElement(tag);
    if (options.class) node.className = options.class;
    if (options.style) Object.assign(node.style, options.style);
    node.append(...children.filter((child) => child !== null && child !== undefined));
    return node;
  };
  const page = document.getElementById('page');
  const section = (heading, note, beside) => {
    const node = element('section', {}, element('div', {class: 'head'}, element('h2', {}, heading), beside));
    if (note) node.append(element('p', {class: 'note'}, note));
    page.append(node);
    return node;
  };
  const table = (columns, rows) => {
    const cell = (tag, text, column) => element(tag, {class: column.kind}, String(text));
    const lines = rows.map((row) => element('tr', {}, ...columns.map((c) => cell('td', c.of(row), c))));
    const node = element(
        'table', {}, element('thead', {}, element('tr', {}, ...columns.map((c) => cell('th', c.name, c)))),
        element('tbody', {}, ...lines));
    return {node: element('div', {class: 'scroll'}, node), lines};
  };
  const list = (texts) => element('ul', {}, ...texts.map((text) => element('li', {}, text)));
  const folded = (label, ...content) => element('details', {}, element('summary', {}, label), ...content);
  const legend = (...entries) => element(
      'div', {class: 'legend'},
      ...entries.map(([color, label]) => element('span', {}, element('i', {style: {background: color}}), label)));

  // Charts.
  Chart.defaults.animation = false;
  Chart.defaults.font.family = getComputedStyle(body).fontFamily;
  Chart.defaults.font.size = 12;
  Chart.defaults.color = '#5b6876';
  Chart.defaults.maintainAspectRatio = false;
  Chart.defaults.plugins.legend.display = false;
  Chart.defaults.elements.point.radius = 0;
  Chart.defaults.elements.line.borderWidth = 1.4;
  Chart.defaults.scale.grid.color = '#edf0f3';
  Chart.defaults.scale.grid.borderColor = '#c6ced6';
  Chart.defaults.scale.ticks.maxRotation = 0;

  const countDrawn = {id: 'countDrawn', afterRender(chart) { chart.canvas.dataset.drawn = 'yes'; }};
  // Vertical bands behind the lines: options.plugins.bands = [{from, to, color}].
  const bands = {
    id: 'bands',
    beforeDatasetsDraw(chart, _, options) {
      const {ctx, chartArea: area, scales: {x}} = chart;
      for (const {from, to, color} of options.list ? options.list() : []) {
        const left = Math.max(area.left, Math.min(area.right, x.getPixelForValue(from)));
        const right = Math.max(area.left, Math.min(area.right, x.getPixelForValue(to)));
        ctx.save();
        ctx.fillStyle = color;
        ctx.fillRect(left, area.top, Math.max(right - left, 2), area.bottom - area.top);
        ctx.restore();
      }
    },
  };
  // Lines across the chart at values of one axis: options.plugins.marks = {axis, values, color}.
  const marks = {
    id: 'marks',
    afterDatasetsDraw(chart, _, {axis, values, color}) {
      if (!values) return;
      const {ctx, chartArea: area, scales} = chart;
      ctx.save();
      ctx.strokeStyle = color || '#5b6876';
      ctx.setLineDash([5, 4]);
      for (const value of values) {
        const at = scales[axis].getPixelForValue(value);
        ctx.beginPath();
        if (axis === 'x') {
          ctx.moveTo(at, area.top);
          ctx.lineTo(at, area.bottom);
        } else {
          ctx.moveTo(area.left, at);
          ctx.lineTo(area.right, at);
        }
        ctx.stroke();
      }
      ctx.restore();
    },
  };
  // Error bars from x_sd or y_sd of the points of a data set with `errors: "x"` or `"y"`.
  const errors = {
    id: 'errors',
    afterDatasetsDraw(chart) {
      const {ctx, scales} = chart;
      chart.data.datasets.forEach((set, index) => {
        if (!set.errors) return;
        ctx.save();
        ctx.strokeStyle = set.errorColor || '#1c2733';
        ctx.lineWidth = 1.2;
        chart.getDatasetMeta(index).data.forEach((point, i) => {
          const sd = set.sd[i], scale = scales[set.errors];
          if (!known(sd) || sd <= 0) return;
          const value = set.center[i], low = scale.getPixelForValue(value - sd),
                high = scale.getPixelForValue(value + sd);
          ctx.beginPath();
          if (set.errors === 'x') {
            ctx.moveTo(low, point.y);
            ctx.lineTo(high, point.y);
            for (const end of [low, high]) {
              ctx.moveTo(end, point.y - 3);
              ctx.lineTo(end, point.y + 3);
            }
          } else {
            ctx.moveTo(point.x, low);
            ctx.lineTo(point.x, high);
            for (const end of [low, high]) {
              ctx.moveTo(point.x - 3, end);
              ctx.lineTo(point.x + 3, end);
            }
          }
          ctx.stroke();
        });
        ctx.restore();
      });
    },
  };
  // One meter is as long to the north as to the east: the range of the wider axis grows into the room that is left.
  const equalScales = {
    id: 'equalScales',
    afterLayout(chart, _, {extent}) {
      if (!extent) return;
      const {chartArea: area, scales: {x, y}} = chart;
      const width = area.right - area.left, height = area.bottom - area.top;
      if (width <= 0 || height <= 0) return;
      const perPixel = 1.06 * Math.max((extent.x[1] - extent.x[0]) / width, (extent.y[1] - extent.y[0]) / height, 1e-9);
      for (const [scale, pixels, [low, high]] of [[x, width, extent.x], [y, height, extent.y]]) {
        const middle = (low + high) / 2, min = middle - (perPixel * pixels) / 2, max = middle + (perPixel * pixels) / 2;
        const now = chart.options.scales[scale.id];
        if (Math.abs((now.min ?? 0) - min) + Math.abs((now.max ?? 0) - max) < 0.01 * (max - min)) continue;
        now.min = min;
        now.max = max;
        chart.redo = true;
      }
    },
    afterRender(chart) {
      if (!chart.redo || chart.redone > 3) return;
      chart.redo = false;
      chart.redone = (chart.redone || 0) + 1;
      chart.update('none');
    },
    resize(chart) { chart.redone = 0; },
  };
  Chart.register(countDrawn, bands, marks, errors, equalScales);

  const charts = [];
  const chart = (parent, height, label, config) => {
    const canvas = element('canvas');
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', label);
    parent.append(element('div', {class: 'plot', style: {height: height + 'px'}}, canvas));
    const made = new Chart(canvas, config);
    charts.push(made);
    return made;
  };
  const axisTitle = (text) => ({display: !!text, text});
  const range = (values) =>
      values.filter(known).reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
  // Horizontal bars: rows of {label, value, sd, color, tip}; with {low, high} in place of sd, the bar is that interval.
  const bars = (parent, label, rows, {axis, markValues, min, max, tick} = {}) => {
    const ends =
        rows.flatMap((row) => [row.low ?? row.value - (row.sd ?? 0), row.high ?? row.value + (row.sd ?? 0)]).filter(known);
    chart(parent, 44 + 26 * rows.length + (axis ? 18 : 0), label, {
      type: 'bar',
      data: {
        labels: rows.map((row) => row.label),
        datasets: [{
          data: rows.map((row) => (known(row.low) ? [row.low, row.high] : row.value)),
          backgroundColor: rows.map((row) => row.color || COLOR.grey),
          maxBarThickness: 18,
          errors: rows.some((row) => known(row.sd)) ? 'x' : undefined,
          center: rows.map((row) => row.value),
          sd: rows.map((row) => row.sd),
        }],
      },
      options: {
        indexAxis: 'y',
        scales: {
          x: {
            title: axisTitle(axis),
            suggestedMin: Math.min(min ?? 0, ...ends),
            suggestedMax: Math.max(max ?? 0, ...ends),
            ticks: {callback: tick || ((v) => short(v, 6))}
          },
          y: {grid: {display: false}, ticks: {autoSkip: false, color: '#1c2733'}},
        },
        plugins: {
          marks: {axis: 'x', values: markValues, color: '#1c2733'},
          tooltip: {callbacks: {label: (item) => rows[item.dataIndex].tip || short(rows[item.dataIndex].value)}},
        },
      },
    });
  };

  // Verdict.
  const VERDICT = {mismatch: 'mismatch', 'no-mismatch': 'no mismatch', undecided: 'undecided'};
  const {verdict, sentence} = explanation || findings;
  const hero = element('div', {class: 'hero ' + verdict});
  page.append(hero);
  hero.append(element('div', {class: 'title'}, title));
  hero.append(element('h1', {}, element('span', {class: 'badge'}, VERDICT[verdict]), sentence));
  if (detection.reason) hero.append(element('p', {}, detection.reason));

  const cards = element('div', {class: 'cards'});
  hero.append(cards);
  const card = (label, value, unit, below) => cards.append(element(
      'div', {class: 'card'}, element('div', {class: 'label'}, label),
      element('div', {class: 'value'}, value, element('small', {}, ' ' + unit)),
      element('div', {class: 'below'}, below)));
  const UNIT = {surge: 'mm/s\u00b2', sway: 'mm/s\u00b2', yaw: 'deg/s\u00b2'};
  for (const axis of AXES) {
    const [scale, unit] = axis === 'yaw' ? [1, 'degps2'] : [1e3, 'mps2'];
    card(
        'Model error, ' + axis,
        withSd(
            scale * sigma[axis + '_' + unit],
            known(sigma[axis + '_sd_' + unit]) ? scale * sigma[axis + '_sd_' + unit] : null),
        UNIT[axis], percent(sigma[axis + '_share_of_typical']) + ' of the typical acceleration');
  }
  const gain = explanation && explanation.chosen.length > 0 ?
      [explanation.heldout_gain_nats, explanation.heldout_gain_sd_nats] :
      [detection.heldout_gain, detection.heldout_gain_sd];
  card(
      'Chance, if nothing is missing', pValue((explanation || findings).p_value), '',
      detection.effects.length === 0 ? '' : 'held-out gain ' + withSd(...gain) + ' nats');
  hero.append(element(
      'p', {class: 'note'},
      'Model error: standard deviation of the acceleration that the simulator lacks to follow the recordings' +
          (known(sigma.tau_s) && sigma.tau_s > 0 ? `, correlated over ${short(sigma.tau_s)} s.` : '.')));

  if (findings.ensemble) {
    const {name, members, outside_share: outside, members_sd: sd} = findings.ensemble;
    hero.append(element(
        'p', {class: 'note'},
        `Simulator: the ensemble ${name} of ${members} networks. Standard deviation of their accelerations: surge ` +
            `${short(1e3 * sd.surge_mps2, 2)}, sway ${short(1e3 * sd.sway_mps2, 2)} mm/s\u00b2, yaw ` +
            `${short(sd.yaw_degps2, 2)} deg/s\u00b2. Beyond the training data: ${percent(outside)} of the points.`));
  }

  const warn = (text) => hero.append(element('div', {class: 'warning'}, text));
  for (const reading of conventions.contradicted) warn(reading.sentence);
  for (const fault of audit.faults)
    warn(fault.sentence + (findings.faults_taken_out ? ' (taken out before the fit)' : ' (still in the data)'));
  if (!fit.converged)
    warn(`The fit has not converged after ${fit.iterations} iterations: do not rely on what follows.`);

  // What.
  if (explanation) {
    const what = section(
        'What is missing',
        'Effects that were fitted to the recordings beside the ship\'s uncertain parameters, by their probability. ' +
            'Held-out gain: how much better [nats] what was left out is predicted than by the simulator as it is.');
    const shown = explanation.hypotheses.slice(0, 10);
    bars(
        what, 'probability of what may be missing',
        shown.map((h) => ({
                    label: h.name === 'none' ? 'nothing' : h.name,
                    value: h.probability,
                    color: h.effects.length > 0 && h.effects.every((e) => explanation.chosen.includes(e)) ? COLOR.sway :
                                                                                                         COLOR.grey,
                    tip: `${short(h.probability)}: ${h.sentence}`,
                  })),
        {axis: 'probability', min: 0, max: 1});
    const rows = shown.flatMap(
        (h) => (Object.keys(h.parameters).length > 0 ? Object.entries(h.parameters) : [[null, null]])
                   .map(([name, p], i) => ({h, name, p, first: i === 0})));
    what.append(table(
                    [
                      {name: 'Missing', of: ({h, first}) => (first ? (h.name === 'none' ? 'nothing' : h.name) : '')},
                      {name: 'Evidence [nats]', of: ({h, first}) => (first ? short(h.log_evidence) : ''), kind: 'number'},
                      {
                        name: 'Held-out gain [nats]',
                        of: ({h, first}) => (first ? withSd(h.heldout_gain_nats, h.heldout_gain_sd_nats) : ''),
                        kind: 'number'
                      },
                      {name: 'Parameter', of: ({name}) => name || ''},
                      {name: 'Estimate', of: ({p}) => (p ? withSd(p.estimate, p.sd) + printed(p.unit) : ''), kind: 'number'},
                      {
                        name: '95 %',
                        of: ({p}) => (p ? between(p.ci95) : ''),
                        kind: 'number'
                      },
                    ],
                    rows)
                    .node);

    // Parameters against what was believed before.
    const learnt = rows.filter(({h, p}) => p && known(p.prior95?.[0]) && h.effects.every((e) => explanation.chosen.includes(e)));
    if (learnt.length > 0) {
      const share = (p, x) => (x - p.prior95[0]) / (p.prior95[1] - p.prior95[0]);
      bars(
          what, 'parameters against what was believed before',
          learnt.map(({name, p}) => ({
                       label: name,
                       low: Math.max(-0.5, share(p, p.ci95[0])),
                       high: Math.min(1.5, share(p, p.ci95[1])),
                       value: share(p, p.estimate),
                       color: COLOR.sway,
                       tip: `${withSd(p.estimate, p.sd)}${printed(p.unit)}, 95 % ${between(p.ci95)}; ` +
                           `before ${short(p.prior95[0])} to ${short(p.prior95[1])}`,
                     })),
          {
            axis: '95 % interval, within that of what was believed before (0 to 1)',
            markValues: [0, 1],
            min: 0,
            max: 1,
          });
    }

    // What looks alike.
    const {effects: alike, shares} = detection.imitation;
    if (alike.length > 1) {
      const part = section(
          'What looks alike in these recordings',
          'How much of what the effect of a row would do another effect can imitate, once the ship\'s own parameters ' +
              'have done what they can: 0 (white) none, 1 (dark) all of it.');
      const side = Math.max(10, Math.min(24, 620 / alike.length));
      chart(part, 190 + side * alike.length, 'imitation of effects by effects', {
        type: 'scatter',
        data: {
          datasets: [{
            data: shares.flatMap((row, i) => row.map((share, j) => ({x: j, y: i, share}))),
            pointStyle: 'rect',
            radius: side * 0.68,
            hoverRadius: side * 0.68,
            borderWidth: 0,
            backgroundColor: shares.flatMap((row) => row.map((share) => clear(COLOR.surge, share))),
          }]
        },
        options: {
          layout: {padding: {right: 20}},
          scales: {
            x: {
              min: -0.6,
              max: alike.length - 0.4,
              position: 'top',
              title: axisTitle('imitated by'),
              grid: {display: false},
              afterBuildTicks: (axis) => { axis.ticks = alike.map((_, i) => ({value: i})); },
              ticks: {autoSkip: false, minRotation: 60, maxRotation: 60, callback: (v) => alike[v]},
            },
            y: {
              min: -0.6,
              max: alike.length - 0.4,
              reverse: true,
              grid: {display: false},
              afterBuildTicks: (axis) => { axis.ticks = alike.map((_, i) => ({value: i})); },
              ticks: {autoSkip: false, callback: (v) => alike[v]},
            },
          },
          plugins: {
            tooltip: {
              callbacks: {label: ({raw}) => `${alike[raw.y]} by ${alike[raw.x]}: ${percent(raw.share)}`},
            },
          },
        },
      });
    }

    // What would tell.
    const {next} = explanation;
    if (next.maneuvers.length > 0) {
      const menu = section(
          'What would tell',
          'Maneuvers simulated under each hypothesis that is still possible, with the noise and the model error of ' +
              'these recordings: the probability of the right name that is to be expected afterwards. Now it is ' +
              short(next.p_right_now, 2) + '.');
      bars(
          menu, 'expected probability of the right name',
          next.maneuvers.map((m) => ({
                               label: `${m.maneuver} (${short(m.duration_s)} s)`,
                               value: m.p_right,
                               color: m.p_right >= 0.95 ? COLOR.sway : COLOR.grey,
                               tip: `${short(m.p_right)}: ${m.command}`,
                             })),
          {axis: 'expected probability of the right name', markValues: [next.p_right_now], min: 0, max: 1});
    }

    const fits = section(
        'Fit before and after',
        'Root mean square errors of free runs from recorded states with the recorded inputs. Held out: ' +
            (explanation.heldout_is_given ? 'recordings that nothing was fitted to.' :
                                            'each part of the recordings with what was fitted to the others.'));
    const lines = [];
    for (const [name, fit] of [['held out', explanation.fit.heldout], ['fitted', explanation.fit.train]])
      for (const horizon of Object.keys(fit.before.free_runs))
        lines.push({name, horizon, before: fit.before.free_runs[horizon], after: fit.after.free_runs[horizon]});
    const both = (key) => ({before, after}) => `${short(before[key])} \u2192 ${short(after[key])}`;
    fits.append(table(
                    [
                      {name: 'Recordings', of: (l) => l.name},
                      {name: 'Run [s]', of: (l) => l.horizon, kind: 'number'},
                      {name: 'u [m/s]', of: both('rmse_u_mps'), kind: 'number'},
                      {name: 'v_m [m/s]', of: both('rmse_vm_mps'), kind: 'number'},
                      {name: 'r [deg/s]', of: both('rmse_r_degps'), kind: 'number'},
                      {name: 'position [m]', of: both('rmse_position_m'), kind: 'number'},
                    ],
                    lines)
                    .node);
    const held = explanation.fit.heldout;
    bars(
        fits, 'position error of held-out runs of 100 s by recording, before and after',
        Object.keys(held.before.recordings).slice(0, 20).flatMap((name) => [
          {label: `${name} before`, value: held.before.recordings[name].rmse_position_m, color: COLOR.grey},
          {label: 'after', value: held.after.recordings[name]?.rmse_position_m, color: COLOR.sway},
        ]),
        {axis: 'position error of held-out runs of 100 s [m]', min: 0});

    // Tracks.
    const {tracks} = explanation;
    if (tracks.length > 0) {
      const pick = element('select');
      pick.setAttribute('aria-label', 'recording of the tracks');
      tracks.forEach((track, i) => {
        const option = element('option', {}, track.recording);
        option.value = String(i);
        pick.append(option);
      });
      const part = section(
          'Held-out tracks before and after',
          'Free runs of 100 s, one after another from recorded states, with the recorded inputs.',
          tracks.length > 1 ? pick : element('span', {class: 'soft'}, tracks[0].recording));
      const points = (xs, ys) => xs.map((x, i) => ({x: ys[i] ?? NaN, y: x ?? NaN}));
      const map = chart(part, 420, 'tracks before and after', {
        type: 'line',
        data: {
          datasets: [
            {label: 'recorded', borderColor: '#1c2733', borderWidth: 2, data: []},
            {label: 'before', borderColor: COLOR.yaw, borderWidth: 1.5, data: []},
            {label: 'after', borderColor: COLOR.sway, borderWidth: 1.5, data: []},
          ]
        },
        options: {
          parsing: false,
          scales: {
            x: {type: 'linear', title: axisTitle('y0 [m], east'), ticks: {callback: (v) => short(v, 5), includeBounds: false}},
            y: {type: 'linear', title: axisTitle('x0 [m], north'), ticks: {callback: (v) => short(v, 5), includeBounds: false}},
          },
          plugins: {tooltip: {enabled: false}, equalScales: {}},
        },
      });
      const draw = (track) => {
        map.data.datasets[0].data = points(track.before.measured_x0_m, track.before.measured_y0_m);
        map.data.datasets[1].data = points(track.before.x0_m, track.before.y0_m);
        map.data.datasets[2].data = points(track.after.x0_m, track.after.y0_m);
        map.options.plugins.equalScales = {
          extent: {
            x: range([...track.before.measured_y0_m, ...track.before.y0_m, ...track.after.y0_m]),
            y: range([...track.before.measured_x0_m, ...track.before.x0_m, ...track.after.x0_m]),
          }
        };
        map.redone = 0;
        map.update('none');
      };
      pick.addEventListener('change', () => draw(tracks[Number(pick.value)]));
      draw(tracks[0]);
      part.append(legend(['#1c2733', 'recorded'], [COLOR.yaw, 'before'], [COLOR.sway, 'after']));
    }
  }

  // When.
  const isUntrained = (interval) => interval.cause === 'untrained region';
  const intervalsOf = (recording) =>
      located.intervals.filter((i) => i.recording === recording.recording && i.file === recording.file);
  const drawn = recordings.filter((recording) => recording.lines.some((line) => line.t_s.length > 1));
  let choose = null;
  let show = () => {};

  if (drawn.length > 0) {
    if (drawn.length > 1) {
      choose = element('select');
      choose.setAttribute('aria-label', 'recording');
      drawn.forEach((recording, i) => {
        const n = intervalsOf(recording).length;
        const option = element('option', {}, recording.recording + (n > 0 ? `  (${n} located)` : ''));
        option.value = String(i);
        choose.append(option);
      });
    }
    const when = section(
        'When: residual acceleration',
        'What has to be added to the simulator\'s acceleration, with a band of two standard deviations. Where the band' +
            ' leaves zero out, the simulator alone does not explain the recording.',
        choose || element('span', {class: 'soft'}, drawn[0].recording));
    const factor = AXES.map((_, a) => {
      if (a < 2) return [1e3, 'mm/s\u00b2'];
      let top = 0;
      for (const recording of drawn)
        for (const value of recording.lines[2].value) top = Math.max(top, Math.abs(value ?? 0));
      return top < 0.1 ? [1e3, '10\u207b\u00b3 deg/s\u00b2'] : [1, 'deg/s\u00b2'];
    });
    let current = drawn[0];
    const lines = AXES.map(
        (axis, a) => chart(when, a === 2 ? 190 : 168, `residual ${axis} acceleration over time`, {
          type: 'line',
          data: {
            datasets: [
              {label: 'high', borderWidth: 0, backgroundColor: clear(COLOR[axis], 0.2), fill: '+1', data: []},
              {label: 'low', borderWidth: 0, fill: false, data: []},
              {label: axis, borderColor: COLOR[axis], data: []},
              {label: 'with what was missing', borderColor: '#1c2733', borderWidth: 1, data: []},
            ]
          },
          options: {
            parsing: false,
            normalized: true,
            layout: {padding: {right: 18}},
            interaction: {mode: 'nearest', axis: 'x', intersect: false},
            scales: {
              x: {
                type: 'linear',
                title: axisTitle(a === 2 ? 'time [s]' : ''),
                ticks: {display: a === 2, maxTicksLimit: 16, includeBounds: false}
              },
              y: {
                title: axisTitle(`${axis} [${factor[a][1]}]`),
                ticks: {maxTicksLimit: 6},
                afterFit(scale) { scale.width = 74; },
              },
            },
            plugins: {
              bands: {
                list: () => intervalsOf(current).map(
                    (i) =>
                        ({
                          from: i.t_start_s,
                          to: i.t_end_s,
                          color: clear(isUntrained(i) ? COLOR.grey : COLOR.located, i.dof === axis ? 0.34 : 0.13)
                        }))
              },
              marks: {axis: 'y', values: [0], color: '#9aa5b1'},
              tooltip: {
                filter: (item) => item.datasetIndex === 2,
                callbacks: {
                  title: (items) => (items.length > 0 ? `t = ${short(items[0].parsed.x, 6)} s` : ''),
                  label: (item) => `${axis} ${short(item.parsed.y)} ${factor[a][1]}`,
                },
              },
            },
          },
        }));
    const shades = [
      [clear(COLOR.located, 0.5), 'located interval, on the axis where it shows most'],
      [clear(COLOR.located, 0.2), 'the same interval on the other axes'],
    ];
    if (located.intervals.some(isUntrained)) shades.push([clear(COLOR.grey, 0.5), 'for which the ensemble was not trained']);
    when.append(legend(
        ...(located.intervals.length > 0 ? shades : []), [clear(COLOR.grey, 0.35), 'two standard deviations'],
        ...(explanation?.residuals_after.length > 0 ? [['#1c2733', 'with what was missing']] : [])));

    // Track and intervals.
    const withTrack = drawn.some((recording) => recording.track);
    let track = null, trackBox = null;
    if (located.intervals.length > 0 || withTrack) {
      const where = section(
          located.intervals.length > 0 ? 'Located intervals' : 'Track',
          located.intervals.length > 0 ?
              'Stretches where the residual is too large and too steady for chance; the probability' +
                  ' holds for all stretches of all recordings together.' :
              '');
      const grid = element('div', {class: 'grid ' + (located.intervals.length > 0 && withTrack ? 'wide-narrow' : '')});
      where.append(grid);
      if (located.intervals.length > 0) {
        const shown = located.intervals.slice(0, 40);
        const ensembleColumns = [
          {name: 'Beyond the training data', of: (i) => percent(i.training.outside_share), kind: 'number'},
          {name: 'Mean / members\' sd', of: (i) => short(i.training.mismatch_by_members_sd, 2), kind: 'number'},
          {name: 'Cause', of: (i) => i.cause ?? 'not known'},
        ];
        const intervals = table(
            [
              {name: 'Recording', of: (i) => i.recording, kind: 'name'},
              {name: 'Time [s]', of: (i) => `${short(i.t_start_s, 5)} \u2013 ${short(i.t_end_s, 5)}`, kind: 'number'},
              {name: 'Axis', of: (i) => i.dof},
              {
                name: 'Mean',
                of: (i) =>
                    (i.dof === 'yaw' ? short(i.mean_acceleration.yaw_degps2, 2) + ' deg/s\u00b2' :
                                       short(1e3 * i.mean_acceleration[i.dof + '_mps2'], 2) + ' mm/s\u00b2'),
                kind: 'number'
              },
              {name: 'p', of: (i) => pValue(i.p_value), kind: 'number'},
              ...(findings.ensemble ? ensembleColumns : []),
            ],
            shown);
        shown.forEach((interval, row) => {
          const at = drawn.findIndex((r) => r.recording === interval.recording && r.file === interval.file);
          if (at < 0 || !choose) return;
          intervals.lines[row].classList.add('pick');
          intervals.lines[row].title = 'show this recording';
          intervals.lines[row].addEventListener('click', () => {
            choose.value = String(at);
            show();
          });
        });
        intervals.node.classList.add('long');
        if (located.intervals.length > shown.length)
          intervals.node.append(
              element('p', {class: 'note'}, `${located.intervals.length - shown.length} more in locate.json`));
        grid.append(intervals.node);
      }
      if (withTrack) {
        trackBox = element('div');
        grid.append(trackBox);
        track = chart(trackBox, 380, 'track with the located intervals', {
          type: 'line',
          data: {datasets: []},
          options: {
            parsing: false,
            interaction: {mode: 'nearest', axis: 'xy', intersect: false},
            scales: {
              x: {
                type: 'linear',
                title: axisTitle('y0 [m], east'),
                ticks: {callback: (v) => short(v, 5), includeBounds: false}
              },
              y: {
                type: 'linear',
                title: axisTitle('x0 [m], north'),
                ticks: {callback: (v) => short(v, 5), includeBounds: false}
              },
            },
            plugins: {
              equalScales: {},
              tooltip: {callbacks: {title: () => '', label: (item) => `t = ${short(item.raw.t, 6)} s`}},
            },
          },
        });
        trackBox.append(legend(
            [COLOR.grey, 'track'], ...(located.intervals.length > 0 ? [[COLOR.located, 'located']] : []),
            [COLOR.surge, 'start']));
      }
    }

    show = () => {
      current = drawn[choose ? Number(choose.value) : 0];
      const times = current.lines.flatMap((line) => [line.t_s[0], line.t_s[line.t_s.length - 1]]).filter(known);
      lines.forEach((plot, a) => {
        const {t_s: t, value, sd} = current.lines[a], scale = factor[a][0];
        const sets = plot.data.datasets;
        // Between the points of a thinned line are others: there the band spans that of both neighbors.
        const reach = current.thinned ? 1 : 0;
        const edge = (side, choose) => t.map((x, i) => {
          const near = [];
          for (let k = Math.max(0, i - reach); k <= Math.min(t.length - 1, i + reach); ++k)
            if (known(value[k]) && known(sd[k])) near.push(scale * (value[k] + side * 2 * sd[k]));
          return {x, y: known(value[i]) && near.length > 0 ? choose(...near) : NaN};
        });
        sets[0].data = edge(1, Math.max);
        sets[1].data = edge(-1, Math.min);
        sets[2].data = t.map((x, i) => ({x, y: known(value[i]) ? scale * value[i] : NaN}));
        sets[2].borderWidth = current.thinned ? 0.8 : 1.4;
        const after =
            explanation?.residuals_after.find((r) => r.recording === current.recording && r.file === current.file)?.lines[a];
        sets[3].data = after ? after.t_s.map((x, i) => ({x, y: known(after.value[i]) ? scale * after.value[i] : NaN})) : [];
        plot.options.scales.x.min = Math.min(...times);
        plot.options.scales.x.max = Math.max(...times);
        plot.update('none');
      });
      if (!track) return;
      trackBox.style.display = current.track ? '' : 'none';
      if (!current.track) return;
      const points =
          current.track.t_s.map((t, i) => ({x: current.track.y0_m[i] ?? NaN, y: current.track.x0_m[i] ?? NaN, t}))
              .filter((p) => known(p.t));
      const inside = (p) => intervalsOf(current).some((i) => p.t >= i.t_start_s && p.t <= i.t_end_s);
      const start = points.find((p) => known(p.x) && known(p.y));
      track.data.datasets = [
        {data: start ? [start] : [], pointRadius: 6, pointBackgroundColor: COLOR.surge, pointBorderColor: '#fff'},
        {data: points.map((p) => (inside(p) ? p : {...p, x: NaN, y: NaN})), borderColor: COLOR.located, borderWidth: 5},
        {data: points, borderColor: COLOR.grey, borderWidth: 1.5},
      ];
      track.options.plugins.equalScales = {
        extent: {x: range(points.map((p) => p.x)), y: range(points.map((p) => p.y))}
      };
      track.redone = 0;
      track.update('none');
    };
    if (choose) {
      const first = drawn.findIndex((recording) => intervalsOf(recording).length > 0);
      choose.value = String(Math.max(first, 0));
      choose.addEventListener('change', () => show());
    }
    show();
  }

  // Where on the ship.
  const shares = AXES.filter((axis) => known(located.dof[axis]));
  const hasShares = shares.some((axis) => located.dof[axis] > 0);
  const line = located.line_of_action;
  if (hasShares || (line && known(line.x_F_over_L_pp))) {
    const grid = element('div', {class: 'grid ' + (hasShares && line ? 'two' : '')});
    section('Where it acts on the ship').append(grid);
    if (hasShares) {
      const box = element('div', {}, element('h3', {}, 'Direction: share of what is missing'));
      grid.append(box);
      bars(
          box, 'share of each axis',
          shares.map(
              (axis) =>
                  ({label: axis, value: 100 * located.dof[axis], color: COLOR[axis], tip: percent(located.dof[axis])})),
          {min: 0, max: 100, tick: (v) => v + ' %'});
    }
    if (line && known(line.x_F_over_L_pp)) {
      const x = line.x_F_over_L_pp, sd = line.x_F_over_L_pp_sd ?? 0;
      const reach = Math.max(0.65, Math.min(3, Math.abs(x) + 2 * sd + 0.1));
      const at = Math.max(-reach, Math.min(reach, x));
      const box = element(
          'div', {},
          element(
              'h3', {},
              'Where the side force acts: ' +
                  `${withSd(Math.abs(x), sd)} ship lengths ${x < 0 ? 'astern' : 'ahead'} of midship` +
                  (known(line.x_F_m) ? ` (${short(Math.abs(line.x_F_m))} m)` : '')));
      grid.append(box);
      // The outline of a ship of beam L/6 from above, its bow to the right.
      const half = [[-0.5, 0.06], [-0.46, 0.075], [-0.35, 0.083], [0.25, 0.083], [0.36, 0.074], [0.44, 0.05], [0.5, 0]];
      const outline =
          [...half, ...half.slice(0, -1).reverse().map(([a, b]) => [a, -b]), half[0]].map(([a, b]) => ({x: a, y: b}));
      chart(box, 132, 'line of action along the ship', {
        type: 'line',
        data: {
          datasets: [
            {
              data: [{x: at, y: 0}],
              pointRadius: 7,
              pointBackgroundColor: COLOR.sway,
              pointBorderColor: '#fff',
              errors: 'x',
              center: [at],
              sd: [2 * sd]
            },
            {data: outline, borderColor: '#8c98a4', backgroundColor: '#eef2f5', fill: 'shape', tension: 0},
          ]
        },
        options: {
          parsing: false,
          scales: {
            x: {
              type: 'linear',
              min: -reach,
              max: reach,
              title: axisTitle(
                  'position in ship lengths; stern ' + MINUS +
                  '0.5, midship 0, bow 0.5 (bar: two standard deviations)'),
              ticks: {callback: (v) => short(v, 2), includeBounds: false}
            },
            y: {min: -0.13, max: 0.13, display: false},
          },
          plugins: {
            tooltip: {
              filter: (item) => item.datasetIndex === 0,
              callbacks: {title: () => '', label: () => withSd(x, sd) + ' L_pp'}
            }
          },
        },
      });
    }
  }

  // Frames and modules.
  if (located.frames.length > 0 || located.modules.length > 0) {
    const both = located.frames.length > 0 && located.modules.length > 0;
    const grid = element('div', {class: 'grid ' + (both ? 'two' : '')});
    section('What kind of force it is').append(grid);
    if (located.frames.length > 0) {
      const box = element(
          'div', {}, element('h3', {}, 'In which frame the residual is constant'),
          element(
              'p', {class: 'note'},
              'Log-evidence against no residual at all [nats]: the longer, the better this alone describes it.'));
      grid.append(box);
      bars(
          box, 'evidence of each frame',
          located.frames.map((frame, i) => ({
                               label: frame.meaning,
                               value: frame.log_evidence,
                               color: i === 0 ? COLOR.surge : '#b9c4ce',
                               tip: `${short(frame.log_evidence)} nats, ${percent(frame.share)} of the residual`
                             })),
          {min: 0});
    }
    if (located.modules.length > 0) {
      const box = element(
          'div', {}, element('h3', {}, 'Which part of the model, if it may vary, explains it'),
          element(
              'p', {class: 'note'},
              'Gain of log-likelihood [nats] when the force of one module may vary by a slowly changing factor.'));
      grid.append(box);
      bars(
          box, 'gain of each module',
          located.modules.map(
              (module, i) => ({
                label: module.name,
                value: module.log_likelihood_gain,
                color: i === 0 ? COLOR.surge : '#b9c4ce',
                tip: `${short(module.log_likelihood_gain)} nats; factor varies by ${short(module.gain_sd, 2)}; leaves ${
                    percent(module.sigma_w_factor)} of the model error`
              })),
          {min: 0});
    }
  }

  // Regimes.
  if (located.regime.length > 0) {
    const part = section(
        'What it goes with',
        'Mean residual acceleration in bins of one variable, with two standard errors.' +
            ' Listed is what holds after correction for the number of variables tried.');
    const grid = element('div', {class: 'grid three'});
    part.append(grid);
    const plotted = located.regime.filter((regime) => regime.x.length > 0);
    for (const regime of plotted.slice(0, 9)) {
      const axis = regime.dof, [scale, unit] = axis === 'yaw' ? [1, 'degps2'] : [1e3, 'mps2'];
      const rows = regime.x
                       .map((x, i) => ({
                              x,
                              y: known(regime['mean_' + unit][i]) ? scale * regime['mean_' + unit][i] : NaN,
                              sd: 2 * scale * regime['mean_sd_' + unit][i]
                            }))
                       .filter((row) => known(row.x) && known(row.y));
      const box = element('div', {}, element('h3', {}, regime.sentence));
      grid.append(box);
      const ends = rows.flatMap((row) => [row.y - row.sd, row.y + row.sd]);
      chart(box, 210, regime.sentence, {
        type: 'line',
        data: {
          datasets: [{
            data: rows,
            borderColor: clear(COLOR[axis], 0.6),
            pointRadius: 4,
            pointBackgroundColor: COLOR[axis],
            pointBorderColor: '#fff',
            errors: 'y',
            errorColor: COLOR[axis],
            center: rows.map((row) => row.y),
            sd: rows.map((row) => row.sd)
          }]
        },
        options: {
          parsing: false,
          scales: {
            x: {type: 'linear', title: axisTitle(regime.x_label || regime.variable), ticks: {maxTicksLimit: 7}},
            y: {
              title: axisTitle(`${axis} [${UNIT[axis]}]`),
              suggestedMin: Math.min(0, ...ends),
              suggestedMax: Math.max(0, ...ends),
              ticks: {maxTicksLimit: 6}
            },
          },
          plugins: {
            marks: {axis: 'y', values: [0], color: '#9aa5b1'},
            tooltip: {
              callbacks: {
                title: () => '',
                label: (item) =>
                    `${short(item.raw.y)}${PM}${short(item.raw.sd / 2, 2)} ${UNIT[axis]} at ${short(item.raw.x)}`
              }
            },
          },
        },
      });
      box.append(element(
          'div', {class: 'note'},
          `${regime.relation}, p ${pValue(regime.p_value)}, ${percent(regime.share)} of the ${axis} residual`));
    }
    const rest = located.regime.filter((regime) => regime.x.length === 0 || plotted.indexOf(regime) >= 9);
    if (rest.length > 0)
      part.append(list(rest.map((regime) => `${regime.sentence} (${regime.dof}, p ${pValue(regime.p_value)})`)));
  }

  // Nothing located.
  if (located.intervals.length === 0 && located.regime.length === 0) {
    const texts = {
      mismatch: 'No interval and no variable stands out: the residual is spread over the recordings.',
      'no-mismatch': 'Nothing to locate: no interval, no frame and no variable stands out from noise.',
      undecided: 'Nothing could be located.'
    };
    section('Location').append(element('p', {}, texts[findings.verdict]));
  }

  // Effects and parameters.
  const effects = detection.effects, shifts = Object.entries(fit.parameters);
  if (effects.length > 0) {
    const part = section(
        effects.some((effect) => effect.heldout_gain > 0) ? 'Known effects that would fit' :
                                                            'Known effects: none fits better',
        'Each effect of the catalogue alone, by the log-likelihood that it gains' +
            ' on recordings that it was not fitted to (bar: one standard error). A first look, not a name:' +
            ' gap-explain lets them compete.');
    const shown = effects.filter((effect) => known(effect.heldout_gain)).slice(0, 12);
    if (shown.length > 0)
      bars(
          part, 'held-out gain of each effect',
          shown.map(
              (effect) => ({
                label: effect.name,
                value: effect.heldout_gain,
                sd: effect.heldout_gain_sd,
                color: known(effect.heldout_gain_sd) && effect.heldout_gain > 2 * effect.heldout_gain_sd ? COLOR.surge :
                                                                                                           '#b9c4ce',
                tip: `${withSd(effect.heldout_gain, effect.heldout_gain_sd)} nats, p ${
                    pValue(effect.p_value)}, log Bayes factor ${short(effect.log_bayes_factor)}`
              })),
          {axis: 'held-out gain [nats]'});
    part.append(folded(
        `All ${effects.length} effects as a table`,
        table(
            [
              {name: 'Effect', of: (e) => e.name, kind: 'name'},
              {name: 'Held-out gain [nats]', of: (e) => withSd(e.heldout_gain, e.heldout_gain_sd), kind: 'number'},
              {name: 'Log Bayes factor [nats]', of: (e) => short(e.log_bayes_factor), kind: 'number'},
              {name: 'p alone', of: (e) => pValue(e.p_value), kind: 'number'},
            ],
            effects)
            .node));
  }
  if (detection.untested.length > 0)
    page.append(folded('Effects that these recordings cannot show', list(detection.untested)));
  if (shifts.length > 0) {
    const sorted = shifts.filter(([, p]) => known(p.shift_in_prior_sd))
                       .sort(([, a], [, b]) => Math.abs(b.shift_in_prior_sd) - Math.abs(a.shift_in_prior_sd));
    // Far from the stated value, and not because nothing holds it there.
    const isFar = (p) => Math.abs(p.shift_in_prior_sd) > 2 && Math.abs(Math.log(p.factor)) > 2 * p.factor_sd / p.factor;
    const far = sorted.filter(([, p]) => isFar(p)).length;
    const part = section(
        'How far the ship\'s parameters had to move',
        far > 0 ? `${far} of ${sorted.length} moved by more than two standard deviations of their stated uncertainty:` +
                ' they may stand in for missing physics.' :
                  'None moved by more than two standard deviations of its stated uncertainty.');
    if (sorted.length > 0)
      bars(
          part, 'shift of each parameter',
          sorted.slice(0, 24).map(([name, p]) => ({
                                    label: name,
                                    value: p.shift_in_prior_sd,
                                    color: isFar(p) ? COLOR.yaw : '#8fa6b8',
                                    tip: `${fixed(p.shift_in_prior_sd)} sd: factor ${withSd(p.factor, p.factor_sd)}`
                                  })),
          {axis: 'shift in standard deviations of the stated uncertainty', markValues: [-2, 2], min: -3, max: 3});
    if (sorted.length > 24) part.append(element('p', {class: 'note'}, `${sorted.length - 24} more in locate.json`));
  }

  // Sensors and conventions.
  const sensors = section('Sensors and conventions');
  const faultColumns = [
    {name: 'Fault', of: (f) => f.name, kind: 'name'},
    {
      name: 'Estimate',
      of: (f) => Object.entries(f.parameters)
                     .map(
                         ([name, p]) => (Object.keys(f.parameters).length > 1 ? name + ' ' : '') +
                             withSd(p.estimate, p.sd) + printed(p.unit))
                     .join(', '),
      kind: ''
    },
    {name: 'Held-out gain [nats]', of: (f) => withSd(f.heldout_gain, f.heldout_gain_sd), kind: 'number'},
    {name: 'p', of: (f) => pValue(f.p_value), kind: 'number'},
    {name: 'Meaning', of: (f) => f.sentence},
  ];
  sensors.append(element(
      'p', {},
      audit.faults.length > 0            ? 'The recordings contradict themselves, whatever the forces:' :
          audit.verdict === 'consistent' ? 'No fault of a sensor: the recordings agree with themselves.' :
                                           'The sensors could not be checked.'));
  if (audit.faults.length > 0) sensors.append(table(faultColumns, audit.faults).node);
  if (audit.log_through_water !== null)
    sensors.append(element(
        'p', {},
        audit.log_through_water ? 'The velocities are through the water.' : 'The velocities are over ground.'));
  const channels = Object.entries(audit.channels);
  if (channels.length > 0)
    sensors.append(
        table(
            [
              {name: 'Channel', of: ([name]) => name},
              {name: 'Noise, sd', of: ([, c]) => short(c.noise_sd, 2) + printed(c.unit), kind: 'number'},
              {
                name: 'Correlated over',
                of: ([, c]) => (c.correlation_s === 0 ? 'white' : short(c.correlation_s, 2) + ' s'),
                kind: 'number'
              },
              {
                name: 'Filter',
                of: ([, c]) => (c.filter_s === 0 ? 'none' : short(c.filter_s, 2) + ' s'),
                kind: 'number'
              },
              {name: 'Missing', of: ([, c]) => percent(c.missing_share), kind: 'number'},
              {name: 'Frozen', of: ([, c]) => percent(c.frozen_share), kind: 'number'},
              {
                name: 'Resolution',
                of: ([, c]) => (c.resolution === 0 ? 'continuous' : short(c.resolution, 2) + printed(c.unit)),
                kind: 'number'
              },
            ],
            channels)
            .node);
  if (audit.hypotheses.length > 0)
    sensors.append(folded(
        `All ${audit.hypotheses.length} sensor faults that were tested`, table(faultColumns, audit.hypotheses).node));
  const readings = [
    {name: 'Channel', of: (r) => r.channel},
    {name: 'Read as', of: (r) => r.name},
    {name: 'Log-odds [nats]', of: (r) => short(r.log_odds), kind: 'number'},
    {name: 'Error, ratio', of: (r) => short(r.error_ratio), kind: 'number'},
    {name: 'Meaning', of: (r) => r.sentence},
  ];
  if (conventions.contradicted.length > 0) {
    sensors.append(element('p', {}, 'These channels read better in another way than stated:'));
    sensors.append(table(readings, conventions.contradicted).node);
  } else if (conventions.tested.length > 0) {
    sensors.append(element('p', {}, 'Signs, units and frames: no other reading fits better than the stated one.'));
  }
  if (conventions.tested.length > 0)
    sensors.append(folded(
        `All ${conventions.tested.length} other readings that were tested`, table(readings, conventions.tested).node));

  // Fit and notices.
  const notices = [...findings.notices, ...audit.notices, ...conventions.unchecked];
  if (notices.length > 0) section('To keep in mind').append(list(notices));
  const figures = table(
                      [
                        {name: '', of: ([name]) => name},
                        {name: '', of: ([, value]) => value, kind: 'number'},
                      ],
                      [
                        ['Converged', fit.converged ? 'yes' : 'no'],
                        ['Iterations', String(fit.iterations)],
                        [
                          'Largest gradient, parameters (in prior sd) / noise levels',
                          short(fit.gradient, 2) + ' / ' + short(fit.noise_gradient, 2)
                        ],
                        ['Measurements', String(fit.samples)],
                        ['Outliers set aside', String(fit.outliers)],
                        ['Time step', short(fit.step_s) + ' s'],
                        ['Log-likelihood per measurement', short(fit.log_likelihood_per_sample, 4)],
                        ['Chance that the remaining errors are white noise, p', pValue(detection.whiteness_p_value)],
                        ...Object.entries(fit.noise).map(([name, n]) => ['Noise of ' + name, withSd(n.estimate, n.sd)]),
                      ])
                      .node;
  figures.style.maxWidth = '640px';
  section('The fit').append(figures);
  page.append(element('footer', {}, provenance));

  window.addEventListener('beforeprint', () => charts.forEach((made) => made.resize()));
  body.dataset.charts = String(charts.length);
  body.dataset.ready = 'yes';
})();
