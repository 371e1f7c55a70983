"""From evidence to findings: the only place where a study is judged, with the summaries of its findings.

Here belong the judging of a study by its criteria and by the baseline, the findings, their summaries for people and machines, the
comparison of two results, and the table of planted faults. Results files are read and written in `dataset`; criteria are defined in
`criteria`.
"""
