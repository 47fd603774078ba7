"""The pages in the order of their tabs."""

from __future__ import annotations

from layerjam.workbench.page import Page
from layerjam.workbench.pages.brake import Brake
from layerjam.workbench.pages.drop import Drop
from layerjam.workbench.pages.laboratory import Laboratory
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.pages.vacuum import Vacuum

PAGES: list[type[Page]] = [Brake, Pull, Drop, Vacuum, Laboratory]
