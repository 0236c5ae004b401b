"""Studio: a local page in the browser on which figures are drawn and scenes are watched."""
