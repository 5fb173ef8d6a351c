program pendulum
end program
