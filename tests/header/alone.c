/* Compiled with one header in front of it. */
extern int pc_header_alone;
