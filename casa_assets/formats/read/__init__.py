"""Readers of mesh files, a module for each format."""

from casa_assets.formats.read.formats import load as load
