au BufRead,BufNewFile *.tamp set filetype=tamplang
