"""From evidence to findings: the one place where a study is judged, and what is told of its findings.

Here belong the judging of a study by its criteria and by the baseline, the findings, summaries of them for people and machines, the
comparison of two results, and the table of planted faults. Files are not read or written here, and no criterion is defined here:
see `dataset` and `criteria`.
"""
