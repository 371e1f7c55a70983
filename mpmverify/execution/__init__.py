"""From a declared study to solved, judged and stored runs.

Here belong tasks and their content keys, the evaluation of one run, worker processes and dask workers, and the commands of the
library: run studies, judge stored ones, verify one solver. What is measured and judged is defined in `criteria` and `judgement`, and
files have their layout from `dataset`.
"""
