// What goes wrong while the page is drawn stands in data-errors of its body.
const problems = [];
window.addEventListener('error', (event) => {
  problems.push(String(event.message));
  document.body.dataset.errors = problems.join(' | ');
});
