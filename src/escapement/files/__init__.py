"""Files: outputs that appear complete or not at all, and inputs looked at before use."""
