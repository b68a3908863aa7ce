"""Programs that run our network in a Python package and print one line of JSON; run.py starts them."""
