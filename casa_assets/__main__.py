"""`python -m casa_assets` is the command `casa-assets`."""

from casa_assets.cli.main import main

if __name__ == "__main__":
    main()
