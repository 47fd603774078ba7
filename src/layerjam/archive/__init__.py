"""What was built, measured and calibrated, and what was derived from what, in a database.

`contents.py` says what a file is and which others it names, `store.py` keeps it, `schema.py` has
the tables, `move.py` their versions. Needs the extra `records`; nothing else imports it.
"""
