"""Quality of the shipped weights beside Intel Open Image Denoise; `python -m quality --help` says how."""
