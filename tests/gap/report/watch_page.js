// Runs before the page's own scripts: notes in `seen` whatever a page must not do.
window.seen = [];
for (const name of ['alert', 'confirm', 'prompt']) window[name] = () => seen.push(name + ' was called');
for (const name of ['error', 'warn']) console[name] = (...texts) => seen.push(texts.join(' '));
window.addEventListener('error', (event) => seen.push(event.message || `a ${event.target.tagName} failed`), true);
window.addEventListener('unhandledrejection', (event) => seen.push(String(event.reason)));
document.addEventListener('securitypolicyviolation', (event) => seen.push(`${event.violatedDirective} was violated`));
