"""Parts of appliances: cases, handles, ovens, racks, trim."""
