"""The second house of truth: another structure, run for acceptance only. README.md beside this file says what it is."""
