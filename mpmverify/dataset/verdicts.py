"""The file `verdicts.json` with all findings of a results folder."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results, check_ours
from mpmverify.errors import ResultsError
from mpmverify.judgement.findings import Finding


@dataclass(frozen=True)
class StoredVerdicts:
    """Findings of one study, and the inputs of its file.

    Parameters
    ----------
    findings : tuple of Finding
        The findings.
    inputs : str
        Digest of everything that the study's file depends on.
    stamp : tuple of int
        Size [bytes] and modification time [ns] of the study's file when the findings were written.
    """

    findings: tuple[Finding, ...]
    inputs: str
    stamp: tuple[int, ...]

    def made_from(self, inputs: str, path: Path) -> bool:
        """Whether these findings and the study's file at `path` were both made from these inputs.

        Raises
        ------
        ResultsError
            If the file has changed since the findings were written and is not an mpmverify study.
        """
        stored = self.inputs if self.stamp == _stamp(path) else check_ours(path, "study").get("inputs", "")
        return bool(stored == inputs == self.inputs)


def read_verdicts(results: Results) -> dict[str, StoredVerdicts]:
    """Return the stored findings by study; empty if there is no file.

    Raises
    ------
    ResultsError
        If the file is damaged.
    """
    try:
        studies = json.loads(results.verdicts.read_text(encoding="utf-8"))["studies"]
        return {
            name: StoredVerdicts(
                tuple(Finding.of(finding) for finding in entry["findings"]), entry["inputs"], tuple(entry.get("stamp", ()))
            )
            for name, entry in studies.items()
        }
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ResultsError(f"'{results.verdicts}' is not a list of mpmverify verdicts: delete it and run again") from error


def write_verdicts(results: Results, study: str, inputs: str, findings: Sequence[Finding]) -> None:
    """Replace the findings of one study, after its file was written, and drop those of studies without a file.

    Raises
    ------
    ResultsError
        If the file is damaged, or cannot be written.
    """
    kept = {name: entry for name, entry in read_verdicts(results).items() if results.study(name).exists()}
    kept[study] = StoredVerdicts(tuple(findings), inputs, _stamp(results.study(study)))
    body = {"schema": 1, "studies": {name: asdict(entry) for name, entry in kept.items()}}
    text = json.dumps(body, indent=1, sort_keys=True) + "\n"
    write_atomic(results.verdicts, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def _stamp(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_size, status.st_mtime_ns
