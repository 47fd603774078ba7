"""Analysis of time logs of pressure, acceleration and vacuum."""
