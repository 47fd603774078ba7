"""Drawing without a subject: style, charts, pages, folders of a report."""
