"""`python -m layerjam`."""

from layerjam.cli.start import run

if __name__ == "__main__":
    run()
