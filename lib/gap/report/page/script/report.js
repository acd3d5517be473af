// Reads what was found and draws the page, section by section: `findings` is locate.json as docs/gap-locate.md
// describes it, `explanation` is report.json with what is drawn beside it or null, `recordings` holds thinned
// residuals.
const report = JSON.parse(document.getElementById('data').textContent);

// Of a calibration no hypothesis was asked for.
const isCalibration = report.explanation?.hypotheses.length === 0;

verdictSection(report);
if (report.explanation) {
  heldoutTracksSection(report);
  shipFileSection(report);
  if (!isCalibration) {
    hypothesesSection(report);
    imitationSection(report);
    nextManeuverSection(report);
  }
  beforeAfterSection(report);
}
recordingsSections(report);
shipSection(report);
forceSection(report);
regimesSection(report);
nothingLocatedSection(report);
if (!isCalibration) effectsSection(report);
parametersSection(report);
sensorsSection(report);
noticesSection(report);
fitSection(report);
page.append(element('footer', {}, report.provenance));

window.addEventListener('beforeprint', () => charts.forEach((made) => made.resize()));
document.body.dataset.charts = String(charts.length);
document.body.dataset.ready = 'yes';
