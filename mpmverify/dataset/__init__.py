"""Reading and writing of results as netCDF files: one for each finished run, one for each study, one for the self-test.

The layout of these files, their provenance and the file `verdicts.json` belong here. Nothing is solved, measured or judged here:
`execution` and `judgement` supply what is written.
"""
