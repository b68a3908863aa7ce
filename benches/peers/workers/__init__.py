"""Programs that run.py starts: each runs our network in a Python package and prints one line of JSON."""
