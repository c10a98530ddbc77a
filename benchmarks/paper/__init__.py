"""Tables 1 and 2 and Figure 16 of the paper, made again."""
