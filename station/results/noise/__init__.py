"""The noise of recordings at rest: `noise/1`, text, plots and a page."""
