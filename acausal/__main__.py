"""``python -m acausal``."""

from acausal.cli import main

if __name__ == "__main__":
    main()
