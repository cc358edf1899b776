"""The interface for plug-ins, the package's content and its addons: what code outside the core may import.

    from casa_assets.ext.families import Family
    from casa_assets.ext.plugins import Plugin

    PLUGIN = Plugin(name="tea", version="1.0", families=(...,))

Each name is in one module of this folder. Names in their `__all__` are stable within a version; every other module of
the package may change at any time. Names for users of the package (`casa.Asset`, `casa.build`) are in `casa_assets`.
"""
