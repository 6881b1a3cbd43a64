"""What kinds declare: fields, and what other rooms need to know of each family, with the usual answers."""
