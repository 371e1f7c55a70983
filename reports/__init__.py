"""tbd."""
def render(results, *, fresh=False):
    return results.report/"index.html"
