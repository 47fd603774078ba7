"""What was built, measured and calibrated, and what was derived from what, in a database.

`contents.py` reads a file and what it cites, `store.py` keeps it, `view.py` shows it. `schema.py`
has the tables, `database.py` opens them and brings older ones up. Needs the extra `records`;
nothing else imports it.
"""
