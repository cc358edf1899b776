"""Carcasses of cabinets: boards, cells, niches for appliances, interiors."""
