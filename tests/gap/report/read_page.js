// Runs after the page's own scripts: puts what a reader sees into #reading, as JSON.
(() => {
  const lastPoint = (points) => {
    const {x, y} = points.findLast((point) => Number.isFinite(point.x) && Number.isFinite(point.y)) || {};
    return [x ?? null, y ?? null];
  };

  // What pointing at the first points of a chart shows.
  const tips = (chart) => chart.data.datasets[0].data.slice(0, 12).map((_, index) => {
    chart.tooltip.setActiveElements([{datasetIndex: 0, index}], {x: 0, y: 0});
    chart.update('none');
    return [...chart.tooltip.title, ...chart.tooltip.body.flatMap((part) => part.lines)].join('\n');
  });

  const readChart = (canvas) => {
    const chart = Chart.getChart(canvas), {type, data, options} = chart.config;
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer;
    return {
      label: canvas.getAttribute('aria-label'),
      // A chart that drew has lines, letters and their background.
      is_drawn: canvas.dataset.drawn === 'yes' && new Set(new Uint32Array(pixels)).size > 10,
      axes: Object.values(options.scales).map((scale) => scale.title?.text ?? ''),
      labels: [...data.labels],
      values: type === 'bar' ? data.datasets[0].data : [],
      lines: type === 'line' ? data.datasets.map((set) => ({label: set.label ?? '', last: lastPoint(set.data)})) : [],
      tips: type === 'line' ? [] : tips(chart),
    };
  };

  const all = (parent, selector) => [...parent.querySelectorAll(selector)];
  const readTable = (table) => all(table, 'tr').map((row) => [...row.cells].map((cell) => cell.textContent));

  // What its charts end with once each of the choices is made.
  const readChoice = (section, select) => [...select.options].map((option) => {
    select.value = option.value;
    select.dispatchEvent(new Event('change'));
    return {text: option.textContent, charts: all(section, 'canvas').map((canvas) => readChart(canvas).lines)};
  });

  const readSection = (section) => ({
    heading: section.querySelector('h1, h2, summary')?.textContent ?? '',
    text: section.innerText,
    items: all(section, 'li').map((item) => item.textContent),
    tables: all(section, 'table').map(readTable),
    charts: all(section, 'canvas').map(readChart),
  });

  const read = () => {
    const sections = [...document.getElementById('page').children];
    const shown = sections.map(readSection);
    sections.forEach((section, i) => {
      const select = section.querySelector('select');
      shown[i].choices = select ? readChoice(section, select) : [];
    });
    const recording = document.querySelector('select[aria-label="recording"]');
    const rows = all(document, 'tr.pick').map((row) => {
      row.click();
      return recording.selectedOptions[0].textContent;
    });
    return {
      is_ready: document.body.dataset.ready === 'yes',
      errors: document.body.dataset.errors ?? '',
      charts: Number(document.body.dataset.charts),
      scrolls_sideways: document.documentElement.scrollWidth > innerWidth,
      title: document.title,
      sections: shown,
      picked_by_rows: rows,
      // Every element of the page in its order, and every attribute.
      structure: all(document, '*').map((node) => node.tagName + ' ' + node.getAttributeNames().join(' ')).join('\n'),
      seen,
    };
  };

  window.addEventListener('load', () => setTimeout(() => {
                                    let reading;
                                    try {
                                      reading = read();
                                    } catch (error) {
                                      reading = {is_ready: false, errors: String(error.stack), seen};
                                    }
                                    const node = document.createElement('script');
                                    node.type = 'application/json';
                                    node.id = 'reading';
                                    node.textContent = JSON.stringify(reading).replaceAll('<', '\\u003c');
                                    document.body.append(node);
                                  }, 500));
})();
