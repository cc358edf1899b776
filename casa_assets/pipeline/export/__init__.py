"""Write libraries and kitchens in the form that another program reads, whole or not at all."""
