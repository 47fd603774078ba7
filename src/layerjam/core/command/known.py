"""A result whose numbers are never None."""

from typing import Any

from layerjam.core.errors import NotKnownError


class KnownResult:
    """A feasible result; reading an unknown value raises NotKnownError."""

    def __init__(self, answer: Any) -> None:
        """Wrap a result; raises NotKnownError if it or one of its elements is infeasible."""
        feasible = getattr(answer, "feasible", True)
        if not getattr(feasible, "all", lambda: feasible)():
            raise NotKnownError(getattr(answer, "reason", None) or "the result is infeasible")
        self.__dict__["answer"] = answer

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        return type(self.__dict__["answer"])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        answer = self.__dict__["answer"]
        value = getattr(answer, name)
        if value is None and any(f.name == name for f in answer.keys()):  # noqa: SIM118
            raise NotKnownError(f"{name.replace('_', ' ')}: unknown for this case")
        return value

    def __repr__(self) -> str:
        return repr(self.__dict__["answer"])

    def __reduce__(self) -> "tuple[type[KnownResult], tuple[Any]]":
        return KnownResult, (self.__dict__["answer"],)
