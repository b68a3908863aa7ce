"""Compares the shipped weights with Intel Open Image Denoise; see `python -m quality --help`."""
