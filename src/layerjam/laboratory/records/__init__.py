"""A database of brakes, runs, calibrations and other files, and of their derivation.

`contents.py` reads a file and the digests that it cites, `store.py` adds it, and `view.py` shows
it. `schema.py` defines the tables; `database.py` opens them and upgrades older ones. The package
requires the `records` extra; nothing else imports it.
"""
