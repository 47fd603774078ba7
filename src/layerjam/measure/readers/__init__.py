"""Files of test machines, recognised by their content."""
