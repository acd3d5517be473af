// One recording at a time: its residual over time, the located intervals, its track. All of them show the same one.
const recordingsSections = (report) => {
  const {located} = report.findings;
  const drawn = report.recordings.filter((recording) => recording.lines.some((line) => line.t_s.length > 1));
  if (drawn.length === 0) return;
  const intervalsOf = (r) => located.intervals.filter((i) => i.recording === r.recording && i.file === r.file);
  const pick = choice(
      'recording',
      drawn.length > 1 ? drawn.map((r) => counted(r.recording, intervalsOf(r).length, 'located')) :
                         [drawn[0].recording]);
  const views = [residualsSection(report, drawn, intervalsOf, pick)];
  const showChosen = () => {
    const recording = drawn[drawn.length > 1 ? Number(pick.value) : 0];
    for (const show of views) show(recording);
  };
  const onPick = (recording) => {
    pick.value = String(recording);
    showChosen();
  };
  const withTrack = drawn.some((recording) => recording.track);
  if (located.intervals.length > 0 || withTrack)
    views.push(intervalsSection(report, drawn, intervalsOf, withTrack, onPick));
  if (drawn.length > 1) {
    pick.value = String(Math.max(drawn.findIndex((recording) => intervalsOf(recording).length > 0), 0));
    pick.addEventListener('change', showChosen);
  }
  showChosen();
};

const isUntrained = (interval) => interval.cause === 'untrained region';
