"""Assets -> a folder of objects that RoboCasa's kitchens sample from: models, categories, and how to add them."""
