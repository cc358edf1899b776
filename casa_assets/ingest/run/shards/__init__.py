"""Runs that work on a part of the inputs each, and the merge of their libraries into that of one run over all."""
