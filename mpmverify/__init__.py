"""mpmverify: the bench on which a material point code, or any wave solver, proves that it is right."""

__version__ = "0.1.0"
