"""Results in netCDF files and back: one file for each finished run, one for each study, one for the self-test.

Here belong the layout of these files, their provenance, and `verdicts.json` beside them. Nothing is solved, measured or judged
here: what is written comes from `execution` and `judgement`, and what is read goes there or to the pages.
"""
