"""Programs, started by run.py, that run our network in a Python package and print one line of JSON."""
