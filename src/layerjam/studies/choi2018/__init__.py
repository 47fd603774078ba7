"""The paper reproduced: every claim beside what comes out here."""
