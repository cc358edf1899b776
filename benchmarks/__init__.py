"""Scripts behind every quoted number; `./dev bench` lists them."""
