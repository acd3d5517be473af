// Elements of the page. What comes from outside enters them as text, never as markup.
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
  if (note) node.append(paragraph(note, 'note'));
  page.append(node);
  return node;
};

const paragraph = (text, kind) => element('p', {class: kind}, text);
const list = (texts) => element('ul', {}, ...texts.map((text) => element('li', {}, text)));
const folded = (label, ...content) => element('details', {}, element('summary', {}, label), ...content);

// Boxes beside each other; kind: 'two', 'three', 'wide-narrow' or ''.
const grid = (parent, kind = '') => {
  const node = element('div', {class: 'grid ' + kind});
  parent.append(node);
  return node;
};
const boxIn = (parent, heading, note) => {
  const node = element('div', {}, heading ? element('h3', {}, heading) : null, note ? paragraph(note, 'note') : null);
  parent.append(node);
  return node;
};

// Columns: {name, of(row), kind}; kind: 'number', 'name' or none.
const table = (columns, rows) => {
  const cell = (tag, text, column) => element(tag, {class: column.kind}, String(text));
  const lines = rows.map((row) => element('tr', {}, ...columns.map((c) => cell('td', c.of(row), c))));
  const head = element('tr', {}, ...columns.map((c) => cell('th', c.name, c)));
  const node = element('table', {}, element('thead', {}, head), element('tbody', {}, ...lines));
  return {node: element('div', {class: 'scroll'}, node), lines};
};

const legend = (...entries) => element(
    'div', {class: 'legend'},
    ...entries.map(([color, label]) => element('span', {}, element('i', {style: {background: color}}), label)));

// A choice among texts; where there is only one of them, it stands there and `value` stays undefined.
const choice = (label, texts) => {
  if (texts.length === 1) return element('span', {class: 'soft'}, texts[0]);
  const node = element('select');
  node.setAttribute('aria-label', label);
  texts.forEach((text, i) => {
    const option = element('option', {}, text);
    option.value = String(i);
    node.append(option);
  });
  return node;
};
