"""What the lab says: traces from test machines' files, and what they tell about a brake."""
